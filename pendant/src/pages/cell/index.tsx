import { t } from '../../i18n';
import { Empty } from '../../ui/controls';

export default function Page() {
  return <Empty icon="cell" text={t('page.soon')} />;
}
